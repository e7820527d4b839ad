function result = ended(said)
% What a job's object holds: its result, or an error. For sga.wait and sga.result.
  switch said.status
    case 'done', result = sga.whole(said.result);
    case 'failed', sga.fail(said.error);
    case 'cancelled', error('sga:cancelled', 'the job %s was cancelled', said.id);
    otherwise, error('sga:pending', 'the job %s is %s', said.id, said.status);
  end
end
