"""Deployment of foldable space membranes: ANCF membranes with wrinkling, fold lines and self-contact."""
