function result = wait(job, seconds)
% result = sga.wait(job)                  the answer, once it is there
% result = sga.wait(job, seconds)         the error sga:timeout where it takes longer; the job goes on
  if nargin < 2, seconds = Inf; end
  begun = tic;
  said = struct('status', 'queued');
  while any(strcmp(said.status, {'queued', 'running'}))
    left = seconds - toc(begun);
    if left <= 0, error('sga:timeout', 'the job %s is %s after %g seconds', job.id, said.status, seconds); end
    said = sga.ask(job.server, 'GET', ['/v1/jobs/' job.id], '', max(1, floor(min(20, left))));
  end
  result = sga.ended(said);
end
