function [status, body] = ask_matlab(method, url, text, seconds)
% The exchange by MATLAB's own HTTP. This file was not run: no MATLAB was there.
  fields = [matlab.net.http.HeaderField('Prefer', sprintf('wait=%d', seconds)), matlab.net.http.HeaderField('Content-Type', 'application/json')];
  if ~isempty(getenv('SGA_TOKEN'))
    fields = [fields, matlab.net.http.HeaderField('Authorization', ['Bearer ' getenv('SGA_TOKEN')])];
  end
  request = matlab.net.http.RequestMessage(method, fields);
  if ~isempty(text)
    request.Body = matlab.net.http.MessageBody();
    request.Body.Payload = unicode2native(text, 'UTF-8');
  end
  options = matlab.net.http.HTTPOptions('ConvertResponse', false, 'SavePayload', true, 'ResponseTimeout', seconds + 60);
  reply = send(request, matlab.net.URI(url), options);
  status = double(reply.StatusCode);
  body = native2unicode(reply.Body.Payload(:).', 'UTF-8');
end
