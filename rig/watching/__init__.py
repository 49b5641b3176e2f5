"""Watch and steer a run in a browser: another process, which reads the run's folder."""
