"""Contacts that another engine or another model simulates."""
