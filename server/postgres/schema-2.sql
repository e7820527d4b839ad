-- What is kept, by bytes and age, without reading rows. A daemon that knows the first step only goes on beside this one.
CREATE INDEX jobs_kept ON jobs(finished) INCLUDE (bytes) WHERE status >= 2;
CREATE INDEX results_made ON results(made);
