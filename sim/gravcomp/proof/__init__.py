"""What shows that the core is right: pose sets, error statistics, tables and pictures of a simulated run."""
