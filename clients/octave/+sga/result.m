function answer = result(job)
% result = sga.result(job)                the answer of a job that has ended; the error sga:pending where it has not
  answer = sga.ended(sga.ask(job.server, 'GET', ['/v1/jobs/' job.id], '', 0));
end
