function value = decode(text)
% JSON as values of MATLAB. Objects with fixed members are structs; those whose keys are names of yours (see below), and any with a key that
% is no name of MATLAB's, are containers.Map: no name changes. Lists of numbers are columns, lists of rows of numbers are matrices with NaN
% for null, other lists are cells (columns); null is [].
  c.text = text;
  [~, c.quotes] = regexp(text, '(?<!\\)(?:\\\\)*"');     % those that end or begin a string
  [~, c.grids] = regexp(text, '\]\s*\]');              % where lists of lists may end
  [value, i] = parse(c, skip(text, 1), false);
  if skip(text, i) <= numel(text), error('sga:reply', 'text after the JSON value at %d', i); end
end

% The members of answers that are objects by name, or lists of such (schema/result.json).
function yes = by_name(member)
  yes = any(strcmp(member, {'combination', 'components', 'derivatives', 'field', 'fields', 'fixed', 'found_at', 'given', 'impulse', 'initial_values', 'irregular_places', 'mode', 'momenta', 'moves', 'not_found_at', 'not_modelled', ...
    'parameters', 'point', 'projected', 'pull_back', 'substituted', 'values'}));
end

function i = skip(text, i)
  while i <= numel(text) && any(text(i) == sprintf(' \t\r\n')), i = i + 1; end
end

function [value, i] = parse(c, i, named)
  if i > numel(c.text), error('sga:reply', 'the JSON ends too soon'); end
  switch c.text(i)
    case '{', [value, i] = object(c, i, named);
    case '[', [value, i] = list(c, i, named);
    case '"', [value, i] = string_at(c, i);
    otherwise, [value, i] = plain(c, i);
  end
end

function [value, i] = plain(c, i)
  j = i;
  while j <= numel(c.text) && ~any(c.text(j) == sprintf(',]} \t\r\n')), j = j + 1; end
  word = c.text(i:j - 1);
  switch word
    case 'true', value = true;
    case 'false', value = false;
    case 'null', value = [];
    otherwise
      value = sscanf(word, '%f');
      if numel(value) ~= 1, error('sga:reply', 'no JSON at %d', i); end
  end
  i = j;
end

function [value, i] = string_at(c, i)
  k = find(c.quotes > i, 1);
  if isempty(k), error('sga:reply', 'a string has no end'); end
  value = c.text(i + 1:c.quotes(k) - 1);
  i = c.quotes(k) + 1;
  if any(value == '\'), value = unescape(value); end
  if isempty(value), value = ''; end
end

function out = unescape(text)
  out = '';
  i = 1;
  while i <= numel(text)
    if text(i) ~= '\'
      out(end + 1) = text(i);
      i = i + 1;
    elseif text(i + 1) == 'u'
      out = [out utf8(hex2dec(text(i + 2:i + 5)))];
      i = i + 6;
    else
      codes = [8 12 10 13 9];
      k = find('bfnrt' == text(i + 1));
      if isempty(k), out(end + 1) = text(i + 1); else, out(end + 1) = char(codes(k)); end
      i = i + 2;
    end
  end
end

% Octave's text is UTF-8, MATLAB's UTF-16.
function text = utf8(code)
  if ~exist('OCTAVE_VERSION', 'builtin') || code < 128
    text = char(code);
  elseif code < 2048
    text = char([192 + floor(code/64), 128 + mod(code, 64)]);
  else
    text = char([224 + floor(code/4096), 128 + mod(floor(code/64), 64), 128 + mod(code, 64)]);
  end
end

function [value, i] = object(c, i, named)
  names = {};
  parts = {};
  i = skip(c.text, i + 1);
  while c.text(i) ~= '}'
    [name, i] = string_at(c, i);
    i = skip(c.text, i);
    if c.text(i) ~= ':', error('sga:reply', 'no : at %d', i); end
    [part, i] = parse(c, skip(c.text, i + 1), ~named && by_name(name));
    names{end + 1} = name;
    parts{end + 1} = part;
    i = skip(c.text, i);
    if c.text(i) == ',', i = skip(c.text, i + 1); end
  end
  i = i + 1;
  if named || ~all(cellfun(@isvarname, names))
    value = containers.Map('KeyType', 'char', 'ValueType', 'any');
    for k = 1:numel(names), value(names{k}) = parts{k}; end
  else
    value = struct();
    for k = 1:numel(names), value.(names{k}) = parts{k}; end
  end
end

% [[1,2],[3,null]] at once; [] in both: it is none.
function [value, after] = grid(c, i)
  value = [];
  after = [];
  k = find(c.grids > i, 1);
  inside = skip(c.text, i + 1);
  if isempty(k) || inside > numel(c.text) || c.text(inside) ~= '[', return; end
  piece = c.text(i:c.grids(k));
  if ~all(ismember(unique(piece), sprintf('0123456789+-.eE,nul[] \t\r\n'))) || c.text(skip(c.text, inside + 1)) == '[', return; end
  rows = sum(piece == '[') - 1;
  number = sscanf(strrep(regexprep(piece, '[\[\],]', ' '), 'null', 'NaN'), '%f');
  if numel(number) ~= sum(piece == ',') + 1 || mod(numel(number), rows), return; end
  columns = numel(number)/rows;
  commas = cumsum(piece == ',');
  begins = find(piece == '[');
  ends = find(piece == ']');
  if any(commas(ends(1:rows)) - commas(begins(2:end)) + 1 ~= columns), return; end
  value = reshape(number, columns, rows).';
  after = c.grids(k) + 1;
end

function [value, i] = list(c, i, named)
  [value, after] = grid(c, i);
  if ~isempty(after)
    i = after;
    return;
  end
  value = {};
  i = skip(c.text, i + 1);
  while c.text(i) ~= ']'
    [value{end + 1, 1}, i] = parse(c, i, named);
    i = skip(c.text, i);
    if c.text(i) == ',', i = skip(c.text, i + 1); end
  end
  i = i + 1;
  if ~isempty(value) && all(cellfun(@(v) isnumeric(v) && isscalar(v), value)), value = vertcat(value{:}); end
end
