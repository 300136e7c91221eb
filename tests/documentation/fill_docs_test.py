"""bench/fill_docs: fills tables and numbers, notices pages that disagree, and explains slips."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

FILL_DOCS = pathlib.Path(__file__).resolve().parents[2] / "bench" / "fill_docs"
RESULTS = 'solver,degree,"time, us"\nMLS,1,0.20431\nIMLS,1,0.33021\nMLS,2,0.96129\n'


class FillDocs(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        (self.root / "cost.csv").write_text(RESULTS)
        self.page = self.root / "page.md"

    def tearDown(self):
        self.folder.cleanup()

    def run_on(self, text, *options):
        self.page.write_text(text)
        command = [sys.executable, FILL_DOCS, "--results", self.root, *options, self.page]
        return subprocess.run(command, capture_output=True, text=True)

    def test_table(self):
        marker = "<!-- table: cost columns: degree; time, us as time rows: solver=MLS digits: 2 -->"
        self.assertEqual(self.run_on(f"a\n{marker}\nold\n<!-- end -->\nb").returncode, 0)
        table = "| degree | time |\n| --- | --- |\n| 1 | 0.2 |\n| 2 | 0.96 |\n"
        self.assertEqual(self.page.read_text(), f"a\n{marker}\n{table}<!-- end -->\nb")

    def test_pivot_and_value(self):
        self.run_on("<!-- table: cost columns: degree pivot: solver of time, us -->\n<!-- end -->"
                    "<!-- value: cost column: time, us rows: solver=MLS, degree=1 -->?<!-- end -->")
        text = self.page.read_text()
        self.assertIn("| degree | MLS | IMLS |\n| --- | --- | --- |\n| 1 | 0.20431 | 0.33021 |", text)
        self.assertIn("| 2 | 0.96129 |  |", text)
        self.assertIn("-->0.20431<!--", text)

    def test_check_notices_and_changes_nothing(self):
        text = "<!-- value: cost column: degree rows: solver=IMLS -->2<!-- end -->"
        result = self.run_on(text, "--check")
        self.assertEqual(result.returncode, 1)
        self.assertIn("page.md:1: value cost disagrees", result.stdout)
        self.assertEqual(self.page.read_text(), text)
        self.assertEqual(self.run_on(text.replace(">2<", ">1<"), "--check").returncode, 0)

    def test_slips(self):
        for marker, message in [("table: none", "cannot read"),
                                ("table: cost columns: price", "no column 'price'"),
                                ("table: cost rows: solver=QR", "no row with solver=QR"),
                                ("value: cost column: degree", "one row, not 3")]:
            result = self.run_on(f"<!-- {marker} --><!-- end -->")
            self.assertEqual(result.returncode, 1)
            self.assertIn(message, result.stderr)
        self.assertIn("no <!-- end -->", self.run_on("<!-- table: cost -->").stderr)


if __name__ == "__main__":
    unittest.main()
