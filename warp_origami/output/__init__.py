"""Files of a run: USD animation, tables, summary, checkpoint."""
