"""What else is done with the full method: labels audited, carried on while a capture runs, another subject's model."""
