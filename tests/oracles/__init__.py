"""Independent references for the models: closed forms and 50-digit arithmetic, no solver of
ours."""
