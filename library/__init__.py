"""What the scenarios that are shipped prove, and the page that says so: docs/coverage.md."""
