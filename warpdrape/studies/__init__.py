"""Many runs of one scene: parameters, designs, running them, the table, effects and maps."""
