"""What a recording can be made into, and bags that it can be made from; each file imports its own library."""
