"""Write docs/paper.md, what the paper's numbers say about each other, from the figures it prints.

python docs/make_paper.py [FOLDER]
"""

import sys
from pathlib import Path

from paper_audit.audit import audit_paper
from paper_audit.page import audit_page

if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    (folder / "paper.md").write_text(audit_page(audit_paper()), encoding="utf-8")
