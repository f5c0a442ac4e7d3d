"""What an answer is worth while the patient is not known: `livermark sensitivity` solves, and what it asks is here."""
