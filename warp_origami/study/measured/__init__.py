"""Runs as processes of their own, with their time, memory and motion measured."""
