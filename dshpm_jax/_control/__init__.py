"""The hierarchy's control: generators that read like the paper, yield requests, and never touch jax."""
