"""What make sim ran: poses, run, errors, pictures."""
