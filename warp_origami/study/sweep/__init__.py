"""Many runs of one scene over values of its keys."""
