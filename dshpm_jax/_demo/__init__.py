"""What `dshpm-jax demo` makes on the spot: one capture from end to end, or a small archive to try every command on."""
