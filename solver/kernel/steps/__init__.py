"""One rule solved for one unknown: every preimage, or why there is none."""
