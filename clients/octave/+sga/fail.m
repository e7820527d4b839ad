function fail(problem)
% The error that a problem object of the daemon is: sga:CODE, with its place.
  if ~isstruct(problem) || ~isfield(problem, 'code'), error('sga:reply', 'the server''s reply cannot be read'); end
  place = '';
  if isfield(problem, 'pointer') && ~isempty(problem.pointer), place = [' at ' problem.pointer]; end
  if isfield(problem, 'column'), place = sprintf('%s, line %d, column %d', place, problem.line, problem.column); end
  error(['sga:' problem.code], '%s%s: %s', problem.code, place, problem.detail);
end
