"""The next measurement, which tells apart what this log could not."""
