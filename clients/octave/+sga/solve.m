function result = solve(request, varargin)
% result = sga.solve(request)             posts the request, waits, and gives the answer
% result = sga.solve(request, 'server', url, 'timeout', seconds)
%
% The request is a struct, a containers.Map where names are none of MATLAB's (such as "x'"), or JSON as text. The daemon's address is
% given, or in the environment as SGA_SERVER; a token is in SGA_TOKEN. An answer is a struct; its objects that have your names as keys
% (components, initial values, gauge fields, ...) are containers.Map, so that no name changes. sga.column takes one column of the samples.
%
% Errors have the identifier sga:CODE, and say where in the request what is wrong.
  job = sga.submit(request, varargin{:});
  seconds = Inf;
  for k = 1:2:numel(varargin)
    if strcmp(varargin{k}, 'timeout'), seconds = varargin{k + 1}; end
  end
  result = sga.wait(job, seconds);
end
