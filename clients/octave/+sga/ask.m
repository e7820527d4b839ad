function said = ask(server, method, path, text, seconds)
% One exchange with a daemon: the object of its reply. Octave has curl do it, MATLAB its own HTTP (sga.ask_matlab).
  url = [regexprep(server, '/+$', '') path];
  if exist('OCTAVE_VERSION', 'builtin')
    [status, body] = ask_curl(method, url, text, seconds);
  else
    [status, body] = sga.ask_matlab(method, url, text, seconds);
  end
  if isempty(strtrim(body)), said = struct(); else, said = sga.decode(body); end
  if status >= 300, sga.fail(said); end
end

function [status, body] = ask_curl(method, url, text, seconds)
% What is sent, and the token, go through files and the environment, not through the command line, which others can read.
  folder = tempname();
  mkdir(folder);
  clean = onCleanup(@() remove(folder));
  put(fullfile(folder, 'config'), sprintf('url = "%s"\nrequest = "%s"\nheader = "Prefer: wait=%d"\nheader = "Content-Type: application/json"\n', ...
      strrep(strrep(url, '\', '\\'), '"', '\"'), method, seconds));
  command = ['curl -sS --max-time ' sprintf('%d', seconds + 60) ' -o "' fullfile(folder, 'body') '" -w "%{http_code}"'];
  if ~isempty(text)
    put(fullfile(folder, 'request'), text);
    command = [command ' --data-binary "@' fullfile(folder, 'request') '"'];
  end
  if ~isempty(getenv('SGA_CA')), command = [command ' --cacert "$SGA_CA"']; end
  token = '';
  if ~isempty(getenv('SGA_TOKEN')), token = 'printf ''header = "Authorization: Bearer %s"\n'' "$SGA_TOKEN"; '; end
  [failed, said] = system(['{ ' token 'cat "' fullfile(folder, 'config') '"; } | ' command ' -K - 2>&1']);
  if failed, error('sga:connection', 'no reply from %s: %s', url, strtrim(said)); end
  status = str2double(said);
  f = fopen(fullfile(folder, 'body'), 'r');
  body = '';
  if f >= 0
    body = char(fread(f, Inf, 'uint8').');
    fclose(f);
  end
end

function put(name, text)
  f = fopen(name, 'w');
  fwrite(f, uint8(text));
  fclose(f);
end

function remove(folder)
  for name = {'config', 'request', 'body'}
    file = fullfile(folder, name{1});
    if exist(file, 'file'), delete(file); end
  end
  rmdir(folder);
end
