-- What is kept, by bytes and age, without reading rows.
CREATE INDEX jobs_kept ON jobs(finished) INCLUDE (bytes) WHERE status >= 2;
CREATE INDEX results_made ON results(made);
-- Where a motion is, in its system's time, as beats tell it; NULL: there is none. It belongs to the stage told with it: a run that was claimed
-- anew has the stage 'running', which no beat tells.
ALTER TABLE jobs ADD COLUMN reached double precision;

CREATE FUNCTION beat_2(p_daemon text, p_version text, p_workers int, p_lease double precision, p_ids text[], p_epochs bigint[], p_stages text[], p_fractions double precision[],
                       p_reached double precision[])
RETURNS TABLE(held text, held_epoch bigint, asked boolean) LANGUAGE plpgsql AS $f$
BEGIN
    INSERT INTO daemons VALUES(p_daemon, p_version, p_workers, clock_timestamp())
        ON CONFLICT(name) DO UPDATE SET version = p_version, workers = p_workers, seen = clock_timestamp();
    RETURN QUERY UPDATE jobs j SET lease = clock_timestamp() + p_lease * interval '1 s', stage = b.stage, fraction = b.fraction, reached = b.reached
        FROM unnest(p_ids, p_epochs, p_stages, p_fractions, p_reached) AS b(id, epoch, stage, fraction, reached)
        WHERE j.id = b.id AND j.epoch = b.epoch AND j.status = 1 RETURNING j.id, j.epoch, j.cancel;
END $f$;
