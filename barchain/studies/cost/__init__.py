"""Work-precision study: what accuracy costs in time, engine by engine, judged by the oracle."""
