"""The report: one page that stands alone, with words, linked plots and a drawing of the peg."""
