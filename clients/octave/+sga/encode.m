function text = encode(value)
% A value as JSON, with all digits: structs and containers.Map are objects, cells and vectors lists, matrices lists of rows. What is to be
% a list with one number is a cell: {1}.
  if ischar(value)
    text = quote(value);
  elseif isa(value, 'containers.Map')
    text = object(keys(value), values(value));
  elseif isstruct(value) && numel(value) == 1
    text = object(fieldnames(value), struct2cell(value));
  elseif isstruct(value)
    text = list(num2cell(value));
  elseif iscell(value)
    text = list(value);
  elseif isnumeric(value) || islogical(value)
    text = numbers(value);
  else
    error('sga:usage', 'a %s has no JSON', class(value));
  end
end

function text = object(names, parts)
  members = cell(1, numel(names));
  for k = 1:numel(names), members{k} = [quote(names{k}) ':' sga.encode(parts{k})]; end
  text = ['{' strjoin(members, ',') '}'];
end

function text = list(parts)
  members = cell(1, numel(parts));
  for k = 1:numel(parts), members{k} = sga.encode(parts{k}); end
  text = ['[' strjoin(members, ',') ']'];
end

function text = numbers(value)
  if isscalar(value)
    if islogical(value)
      words = {'false', 'true'};
      text = words{value + 1};
    elseif isnan(value)
      text = 'null';
    elseif isinf(value) || ~isreal(value)
      error('sga:usage', '%g has no JSON', value);
    else
      text = sprintf('%.17g', value);
    end
  elseif isempty(value)
    text = '[]';
  elseif isvector(value)
    text = list(num2cell(value(:).'));
  else
    text = list(arrayfun(@(k) num2cell(value(k, :)), 1:size(value, 1), 'UniformOutput', false));
  end
end

function text = quote(text)
  text = strrep(strrep(text, '\', '\\'), '"', '\"');
  for code = find(ismember(0:31, double(text))) - 1
    text = strrep(text, char(code), sprintf('\\u%04x', code));
  end
  text = ['"' text '"'];
end
