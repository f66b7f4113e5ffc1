"""What writes files of od/ and docs/: for a checkout, in no wheel."""
