"""Every method that applies to a sheet, measured: time, iterations, and error against 50 digits."""
