function job = submit(request, varargin)
% job = sga.submit(request)               posts the request and does not wait
% job = sga.submit(request, 'server', url)
%
% The job is a struct with id, status and server, for sga.wait, sga.result and sga.cancel.
  server = getenv('SGA_SERVER');
  for k = 1:2:numel(varargin)
    switch varargin{k}
      case 'server', server = varargin{k + 1};
      case 'timeout'
      otherwise, error('sga:usage', 'unknown option %s', varargin{k});
    end
  end
  if isempty(server), error('sga:usage', 'name the server: the option ''server'', or the environment''s SGA_SERVER'); end
  if ischar(request), text = request; else, text = sga.encode(request); end
  said = sga.ask(server, 'POST', '/v1/jobs', text, 0);
  job = struct('id', said.id, 'status', said.status, 'server', server);
end
