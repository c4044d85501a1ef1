"""Run folders from people who mean harm, and the readers that they meet."""
