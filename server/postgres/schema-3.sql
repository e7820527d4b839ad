-- Results of any length: the first piece stands in its row, the others here, by the fence of the run that wrote them, so that neither who writes
-- one nor who reads one has all of it in memory. They are there before the run's end is; what is left of runs that were fenced, or of
-- daemons that died, is swept.
ALTER TABLE results ADD COLUMN pieces bigint NOT NULL DEFAULT 0;        -- whose pieces follow; 0: all of it is in the row
CREATE TABLE pieces(
    id text NOT NULL, epoch bigint NOT NULL, n int NOT NULL,
    made timestamptz NOT NULL DEFAULT clock_timestamp(),
    piece bytea NOT NULL,
    PRIMARY KEY(id, epoch, n)
);
ALTER TABLE pieces ALTER COLUMN piece SET STORAGE EXTERNAL;
CREATE INDEX pieces_made ON pieces(made) WHERE n = 1;

CREATE FUNCTION result_gone() RETURNS trigger LANGUAGE plpgsql AS $f$
BEGIN
    DELETE FROM sgad.pieces WHERE id = old.id AND epoch = old.pieces;        -- whoever deletes, with whatever path
    RETURN NULL;
END $f$;
CREATE TRIGGER result_gone AFTER DELETE ON results FOR EACH ROW WHEN (old.pieces > 0) EXECUTE FUNCTION result_gone();
CREATE TRIGGER result_anew AFTER UPDATE OF pieces ON results FOR EACH ROW WHEN (old.pieces > 0 AND old.pieces <> new.pieces) EXECUTE FUNCTION result_gone();

-- The end of a run whose result begins with p_result and has p_bytes in all, in so many more pieces. 1 kept (also where it was said before), 2 fenced.
CREATE FUNCTION end_2(p_id text, p_epoch bigint, p_status int, p_started bigint, p_finished bigint, p_error text, p_verdict text, p_version text,
                      p_result bytea, p_sum bytea, p_bytes bigint, p_pieces int) RETURNS int LANGUAGE plpgsql AS $f$
BEGIN
    UPDATE jobs SET status = p_status, started = p_started, finished = p_finished, error = p_error, verdict = p_verdict, lease = NULL, stage = NULL
        WHERE id = p_id AND epoch = p_epoch AND status = 1;
    IF NOT FOUND THEN
        IF EXISTS(SELECT 1 FROM jobs WHERE id = p_id AND epoch = p_epoch AND status = p_status) THEN
            RETURN 1;
        END IF;
        DELETE FROM pieces WHERE id = p_id AND epoch = p_epoch;
        RETURN 2;
    END IF;
    IF p_pieces <> (SELECT count(*) FROM pieces WHERE id = p_id AND epoch = p_epoch) THEN
        RAISE EXCEPTION 'of the result of % not all pieces are there', p_id;
    END IF;
    IF p_result IS NOT NULL THEN
        INSERT INTO results(id, version, made, bytes, sum, result, pieces)
            VALUES(p_id, p_version, p_finished, p_bytes, p_sum, p_result, CASE WHEN p_pieces > 0 THEN p_epoch ELSE 0 END)
            ON CONFLICT(id) DO UPDATE SET version = p_version, made = p_finished, used = clock_timestamp(), bytes = p_bytes, sum = p_sum,
                result = p_result, pieces = excluded.pieces;
    END IF;
    RETURN 1;
END $f$;

-- Daemons of the version before write whole results.
CREATE OR REPLACE FUNCTION end_1(p_id text, p_epoch bigint, p_status int, p_started bigint, p_finished bigint, p_error text, p_verdict text, p_version text,
                                 p_result bytea, p_sum bytea) RETURNS int LANGUAGE sql AS $f$
    SELECT end_2(p_id, p_epoch, p_status, p_started, p_finished, p_error, p_verdict, p_version, p_result, p_sum, length(p_result)::bigint, 0)
$f$;
