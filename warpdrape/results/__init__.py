"""What a run leaves: arrays, history, summary, run folder, USD, pictures; and its progress."""
