function value = whole(value)
% answer = sga.whole(answer)              what long lists say once, with a loop, written out: sga.solve, sga.wait and sga.result have done it
  if iscell(value)
    value = list(value);
  elseif isstruct(value) && isscalar(value)
    names = fieldnames(value);
    for k = 1:numel(names), value.(names{k}) = sga.whole(value.(names{k})); end
  elseif isa(value, 'containers.Map')
    value = object(value);
  end
end

function yes = is_family(e)
  yes = isa(e, 'containers.Map') && isKey(e, 'for') && isKey(e, 'count') && isKey(e, 'place') && isnumeric(e('count'));
end

% Families say where their entries stand; the others have the places that are left.
function out = list(in)
  family = cellfun(@is_family, in);
  if ~any(family)
    out = cellfun(@sga.whole, in, 'UniformOutput', false);
    return;
  end
  others = in(~family);
  out = {};
  has = [];
  for e = reshape(in(family), 1, [])
    body = e{1};
    [names, passes] = loop(strsplit(body('for'), ','));
    place = body('place');
    keys = setdiff(body.keys(), {'for', 'count', 'place'});
    for k = 1:size(passes, 1)
      at = number(place, names, passes(k, :)) + 1;
      if isequal(keys, {'expression'}), out{at, 1} = put(body('expression'), names, passes(k, :));
      else, out{at, 1} = put_members(body, keys, names, passes(k, :)); end
      has(at) = true;
    end
  end
  n = sum(has) + numel(others);
  has(end + 1:n) = false;
  out(find(~has), 1) = cellfun(@sga.whole, others, 'UniformOutput', false);
end

function out = object(in)
  out = containers.Map('KeyType', 'char', 'ValueType', 'any');
  for key = in.keys()
    part = regexp(key{1}, '^(\w+)\[([^\[\]]*:[^\[\]]*)\](''*)$', 'tokens', 'once');
    if isempty(part), out(key{1}) = sga.whole(in(key{1})); continue; end
    ranges = strtrim(strsplit(part{2}, ','));
    has = cellfun(@(r) any(r == ':'), ranges);
    [names, passes] = loop(ranges(has));
    for k = 1:size(passes, 1)
      indices = ranges;
      indices(has) = arrayfun(@(v) sprintf('%d', v), passes(k, :), 'UniformOutput', false);
      out([part{1} '[' strjoin(indices, ',') ']' part{3}]) = put(in(key{1}), names, passes(k, :));
    end
  end
end

% "i = 1:2" and "j = 1:3": names, and a row of values for each pass; the last runs fastest.
function [names, passes] = loop(parts)
  names = {};
  passes = zeros(1, 0);
  for k = 1:numel(parts)
    part = regexp(parts{k}, '(\w+)\s*=\s*(\d+):(\d+)', 'tokens', 'once');
    names{k} = part{1};
    values = (str2double(part{2}):str2double(part{3})).';
    rows = size(passes, 1);
    passes = [kron(passes, ones(numel(values), 1)), repmat(values, rows, 1)];
  end
end

% 2*i-1: sums of products of whole numbers and names.
function v = number(text, names, values)
  v = 0;
  for term = regexp(text, '[+-]?[^+-]+', 'match')
    factor = 1;
    for f = strsplit(strrep(strrep(term{1}, '-', ''), '+', ''), '*')
      k = find(strcmp(names, strtrim(f{1})));
      if isempty(k), factor = factor*str2double(f{1}); else, factor = factor*values(k); end
    end
    if term{1}(1) == '-', factor = -factor; end
    v = v + factor;
  end
end

function text = indices(text, names, values)
  parts = strsplit(text, ',');
  text = strjoin(cellfun(@(p) sprintf('%d', number(p, names, values)), parts, 'UniformOutput', false), ',');
end

function value = put(value, names, values)
  if ischar(value)
    [inside, outside] = regexp(value, '(?<=\w\[)[^\[\]]*(?=\])', 'match', 'split');
    inside = cellfun(@(t) indices(t, names, values), inside, 'UniformOutput', false);
    for k = 1:numel(names)
      outside = regexprep(outside, ['(?<![\w.])' names{k} '(?!\w)'], sprintf('%d', values(k)));
    end
    value = [reshape([outside(1:end - 1); inside], 1, []), outside(end)];
    value = [value{:}];
  elseif iscell(value)
    value = cellfun(@(v) put(v, names, values), value, 'UniformOutput', false);
  elseif isstruct(value)
    keys = fieldnames(value);
    for k = 1:numel(keys), value.(keys{k}) = put(value.(keys{k}), names, values); end
  elseif isa(value, 'containers.Map')
    made = containers.Map('KeyType', 'char', 'ValueType', 'any');
    for key = value.keys(), made(put(key{1}, names, values)) = put(value(key{1}), names, values); end
    if isKey(made, 'tangency_of') && ischar(made('tangency_of')), made('tangency_of') = sscanf(made('tangency_of'), 'constraints[%d]'); end
    value = made;
  end
end

function made = put_members(body, keys, names, values)
  made = struct();
  for k = 1:numel(keys), made.(keys{k}) = put(body(keys{k}), names, values); end
end
