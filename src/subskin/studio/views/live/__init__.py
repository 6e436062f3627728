"""A device as it feels, or a recording as it was: what comes is followed in a thread, and told as pages can take it."""
