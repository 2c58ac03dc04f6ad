"""Metrics, quality gates and the report."""
