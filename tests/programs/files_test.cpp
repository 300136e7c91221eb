// Files as they are: names, markers, frames, boxes, and disks that are full.
#include "run_program.hpp"

namespace recon::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Eight by eight points with v = x + 2 y, which any linear fit reproduces.
std::string rows(const std::string& more = "", char delimiter = ',') {
  std::string text;
  for (int i = 0; i < 64; ++i) {
    const std::string x = std::to_string(i % 8), y = std::to_string(i / 8);
    text += x + delimiter + y + delimiter + std::to_string(i % 8 + 2 * (i / 8)) + more + "\n";
  }
  return text;
}

std::string frame(int step, const std::string& bounds, double shift = 0) {
  std::string text = "ITEM: TIMESTEP\n" + std::to_string(step) +
                     "\nITEM: NUMBER OF ATOMS\n64\nITEM: BOX BOUNDS " + bounds +
                     "\nITEM: ATOMS id x y z vx\n";
  for (int i = 0; i < 64; ++i)
    text += std::to_string(i + 1) + " " + std::to_string(i % 8 + 0.5) + " " +
            std::to_string(i / 8 + 0.5) + " 0 " + std::to_string(shift) + "\n";
  return text;
}

const std::string square = "ff ff ff\n0 8\n0 8\n-1 1";

class FilesTest : public ProgramTest {
 protected:
  // Maps v with a linear fit on the grid of the points, and expects v = x + 2 y.
  std::string map_plane(const std::string& arguments, const std::string& field = "v") const {
    std::string out = succeed("map " + arguments + " --fields '" + field +
                              "' --spacing 1 --radius 2.5 --degree 1 --out out.csv");
    const ParticleTable mapped = table("out.csv");
    for (std::size_t i = 0; i < mapped.size(); ++i) {
      EXPECT_NEAR(mapped.column(mapped.names()[2])[i],
                  mapped.column("x")[i] + 2 * mapped.column("y")[i], 1e-12);
    }
    return out;
  }
  // The program's exit code with what a shell does around it.
  int shell(const std::string& before, const std::string& arguments) const {
    const std::string command = "cd '" + folder().string() + "' && " + before + " exec '" +
                                RECON_PROGRAM + "' " + arguments;
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
};

TEST_F(FilesTest, ColumnsThatNobodyAsksFor) {
  write("a.csv", "x,y,v,material,note,note\n" + rows(",304,a,b") + "3.5,3.5,10.5,316L,c,d\n");
  EXPECT_THAT(map_plane("a.csv"), AllOf(HasSubstr("'316L' on line 66"), HasSubstr("note")));
  expect_failure("map a.csv --fields material --out b.csv", 2,
                 AllOf(HasSubstr("column material"), HasSubstr("(line 66) of a.csv = '316L'")));
  expect_failure("map a.csv --fields note --out b.csv", 2,
                 AllOf(HasSubstr("several columns of a.csv"), HasSubstr("5, 6")));
  EXPECT_THAT(succeed("info a.csv"), HasSubstr("65 particles in 2-D"));
}

TEST_F(FilesTest, MissingValues) {
  write("a.csv", "x,y,v,w\n" + rows(",1") + "3.5,3.5,10.5,NA\nNA,1,5,5\n3,3,-9999,5\n");
  expect_failure("map a.csv --fields w --out b.csv", 2, HasSubstr("column x"));
  expect_failure("map a.csv --fields w --missing -9999 --out b.csv", 2,
                 HasSubstr("(line 67) of a.csv = 'NA'"));
  const std::string out = map_plane("a.csv --missing NA --missing -9999");
  EXPECT_THAT(out, AllOf(HasSubstr("65 particles"), HasSubstr("without a value in x: 1 of 67"),
                         HasSubstr("without a value in v: 1 of 66")));
  // The particle without w is there for v, and not for w.
  EXPECT_THAT(succeed("map a.csv --missing NA --fields w --out b.csv"),
              HasSubstr("without a value in w: 1 of 66"));
  EXPECT_THAT(succeed("map a.csv --missing NA --missing -9999 --components both=v,w --out b.csv"),
              HasSubstr("without a value in v, w: 2 of 66"));
  write("b.csv", "x,y,v\n" + rows() + "4,4,\n");
  expect_failure("map b.csv --fields v --out c.csv", 2, HasSubstr("is an empty cell"));
  EXPECT_THAT(map_plane("b.csv --missing ''"), HasSubstr("without a value in v: 1 of 65"));
  write("c.csv", "x,y,v\n1,2,NA\n2,3,NA\n");
  expect_failure("map c.csv --fields v --missing NA --out d.csv", 2, HasSubstr("no particle has"));
}

TEST_F(FilesTest, Headers) {
  write("percent.txt", "% x y v\n" + rows("", ' '));
  write("units.csv", "x,y,v\nm,m,m/s\n" + rows());
  write("names.csv", "run 7, of today\n" + rows());
  map_plane("percent.txt");
  EXPECT_THAT(map_plane("units.csv"), HasSubstr("line 2 holds no number and is taken for units"));
  expect_failure("info names.csv", 2, HasSubstr("names.csv"));
  EXPECT_THAT(succeed("info names.csv --skip-rows 1 --columns x,y,v"), HasSubstr("64 particles"));
  map_plane("names.csv --skip-rows 1 --columns x,y,v");
  expect_failure("map names.csv --skip-rows 1 --columns x,y --fields y --out b.csv", 2,
                 HasSubstr("names.csv:2: the line has 3 cells, the option columns names 2"));
}

TEST_F(FilesTest, NamesThatAreNotUtf8) {
  write("a.csv", "x,y,v\xb2\n" + rows());
  EXPECT_THAT(map_plane("a.csv", "v\xc2\xb2"), HasSubstr("Latin-1"));
  succeed("map a.csv --fields v\xc2\xb2 --spacing 1 --out b.vti");
  EXPECT_THAT(read("b.vti"), HasSubstr("Name=\"v\xc2\xb2\""));
}

TEST_F(FilesTest, FramesByStepAndTime) {
  write("a.dump",
        "ITEM: TIME\n0.1\n" + frame(10, square, 1) + "ITEM: TIME\n0.2\n" + frame(20, square, 2));
  EXPECT_THAT(succeed("map a.dump --step 10 --fields vx --out b.csv"), HasSubstr("step 10"));
  EXPECT_NEAR(table("b.csv").column("vx")[0], 1, 1e-12);
  succeed("map a.dump --time 0.2 --fields vx --out b.csv");
  EXPECT_NEAR(table("b.csv").column("vx")[0], 2, 1e-12);
  expect_failure("info a.dump --step 15", 2, HasSubstr("the file has 10, 20"));
  expect_failure("info a.dump --step 10 --frame 0", 1, HasSubstr("--frame"));
  expect_failure("info a.dump --step 1.5", 1, HasSubstr("whole number"));
}

TEST_F(FilesTest, ATruncatedFile) {
  const std::string two = frame(10, square, 1) + frame(20, square, 2);
  write("a.dump", two.substr(0, two.size() - 300));
  EXPECT_THAT(succeed("info a.dump"), AllOf(HasSubstr("step 10"), HasSubstr("frame 1 is cut off")));
  succeed("map a.dump --fields vx --out b.csv");
  EXPECT_NEAR(table("b.csv").column("vx")[0], 1, 1e-12);
  expect_failure("map a.dump --frame 1 --fields vx --out c.csv", 2,
                 HasSubstr("a.dump:137: the line has 3 cells, for 5 columns"));
  write("b.dump", two.substr(0, two.size() - 1));
  EXPECT_THAT(succeed("info b.dump"), HasSubstr("no line break"));
}

TEST_F(FilesTest, TriclinicBoxes) {
  write("a.dump", frame(0, "xy xz yz pp pp pp\n0 10 2\n0 8 0\n-1 1 0", 3));
  EXPECT_THAT(succeed("info a.dump"),
              AllOf(HasSubstr("periodic in x"), HasSubstr("b = (2, 8, 0) are left out")));
  succeed("map a.dump --fields vx --out b.csv");
  expect_failure("map a.dump --periodic x,y --fields vx --out c.csv", 1,
                 AllOf(HasSubstr("--periodic y"), HasSubstr("triclinic")));
  write("b.dump", frame(0, "xy xz yz pp pp pp\n0 8 0\n0 8 0\n-1 1 0", 3));
  EXPECT_THAT(succeed("info b.dump"), HasSubstr("periodic in x and y"));
}

TEST_F(FilesTest, FullDisks) {
  write("a.csv", "x,y,v\n" + rows());
  const std::string map = "map a.csv --fields v --spacing .05 --out big.vti ";
  const std::vector<std::string> before = files();
  EXPECT_EQ(shell("", "info a.csv > /dev/full 2> .stderr"), 3);
  EXPECT_THAT(read(".stderr"), HasSubstr("standard output cannot be written"));
  EXPECT_EQ(shell("", "help map > /dev/full 2> .stderr"), 3);
  // Files of 512 blocks at most stand for a disk with so much room.
  EXPECT_EQ(shell("trap '' XFSZ && ulimit -f 512 &&", map + "> .stdout 2> .stderr"), 3);
  EXPECT_THAT(read(".stderr"), HasSubstr("big.vti: cannot write"));
  EXPECT_EQ(files(), before);
  write("big.vti", "old");
  EXPECT_EQ(shell("trap '' XFSZ && ulimit -f 512 &&", map + "> .stdout 2> .stderr"), 3);
  EXPECT_EQ(read("big.vti"), "old");
  std::filesystem::create_symlink("/dev/full", folder() / "full.csv");
  expect_failure("map a.csv --fields v --out full.csv", 3, HasSubstr("ordinary file"));
}

// A signal while the program works or writes leaves nothing behind.
TEST_F(FilesTest, Signals) {
  write("a.csv", "x,y,v\n" + rows());
  const std::vector<std::string> before = files();
  for (const char* name : {"INT", "TERM", "HUP"}) {
    const int code =
        shell("{ (sleep 0.3; kill -" + std::string(name) + " $$) & } &&",
              "map a.csv --fields v --spacing .004 --radius 3 --threads 1 --out big.csv "
              "> .stdout 2> .stderr");
    EXPECT_NE(code, 0) << name;
    std::vector<std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator(folder()))
      if (entry.path().filename().string().find(".part") != std::string::npos)
        all.push_back(entry.path().filename().string());
    EXPECT_THAT(all, testing::IsEmpty()) << name;
    EXPECT_EQ(files(), before) << name;
  }
}

}  // namespace
}  // namespace recon::test
