"""The paper's filter: iterations inside a growing pass band (section 3)."""
