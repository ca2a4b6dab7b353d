"""Many runs of a scene: held against known results, or against each other."""
