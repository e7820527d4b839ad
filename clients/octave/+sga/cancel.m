function cancel(job)
% sga.cancel(job)                         nobody waits for it any longer: it ends, unless others asked for the same
  sga.ask(job.server, 'DELETE', ['/v1/jobs/' job.id], '', 0);
end
