"""The paper's experiments (section 5), each one command that writes tables and figures."""
