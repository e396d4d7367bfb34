"""mikas: diagnostics for the Mikas 5.4 and 7.1 engine control units over K-Line."""
