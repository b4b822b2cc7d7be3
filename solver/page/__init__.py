"""A sheet as a page in the browser, served on this machine alone: ``backsolve open``."""
