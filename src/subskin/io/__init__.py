"""Files: `finger.toml`, tables of readings, raw recordings. Units are turned into SI here and nowhere else."""
