#include "mlic_core/io/output_directory.h"

#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <map>

#include "mlic_core/io/text_file.h"
#include "support/files.h"

namespace mlic::output_directory_test {
namespace {

namespace fs = std::filesystem;
using Files = std::map<std::string, std::string>;

// Content of every file below the directory by its path in it.
Files FilesIn(const fs::path& directory) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), directory).string()] = ReadFile(entry.path());
  }
  return files;
}

std::function<void(const fs::path&)> Writer(const Files& files) {
  return [files](const fs::path& directory) {
    for (const auto& [name, content] : files) WriteFileAtomically(directory / name, content);
  };
}

void WriteInto(const fs::path& directory, const Files& files, const std::string& program = "calibrate") {
  OutputDirectory output(directory, program);
  output.Replace(Writer(files));
}

// The results, without the list of them.
Files ResultsIn(const fs::path& directory) {
  Files files = FilesIn(directory);
  files.erase(kManifestName);
  return files;
}

TEST(OutputDirectory, FilesThatMlicDidNotWriteAreRefusedAndStay) {
  TemporaryDirectory directory;
  const Files own{{"calibration.yaml", "mine"},
                  {"images/holiday.png", "x"},
                  {"camera_info/mine.yaml", "x"},
                  {"report.html", "mine"}};
  Writer(own)(directory.Path());
  const std::string error = InputErrorOf([&] { OutputDirectory(directory.Path(), "calibrate"); });
  for (const std::string& part : {directory.Path().string(), std::string("calibration.yaml"),
                                  std::string("and 1 more"), std::string("--output")}) {
    EXPECT_TRUE(Contains(error, part));
  }
  EXPECT_EQ(FilesIn(directory.Path()), own);
}

TEST(OutputDirectory, OfAnEarlierRunNothingIsLeftButWhatOthersAdded) {
  TemporaryDirectory directory;
  const fs::path place = directory.Path() / "new" / "results";
  WriteInto(place, {{"calibration.yaml", "1"},
                    {"trajectory.tum", "1"},
                    {"trajectory_2.tum", "1"},
                    {"images/a.png", "1"},
                    {"camera_info/a.yaml", "1"}});
  WriteFileAtomically(place / "notes.txt", "mine");
  WriteFileAtomically(place / "images" / "holiday.png", "mine");
  WriteInto(place, {{"calibration.yaml", "2"}, {"trajectory.tum", "2"}});
  EXPECT_EQ(ResultsIn(place), (Files{{"calibration.yaml", "2"},
                                     {"trajectory.tum", "2"},
                                     {"notes.txt", "mine"},
                                     {"images/holiday.png", "mine"}}));
  EXPECT_FALSE(fs::exists(place / "camera_info")) << "the empty folder goes too";
}

TEST(OutputDirectory, AChangedFileIsNotLost) {
  TemporaryDirectory directory;
  WriteInto(directory.Path(), {{"calibration.yaml", "1"}, {"report.html", "1"}});
  WriteFileAtomically(directory.Path() / "report.html", "1 and my remarks");
  const Files before = FilesIn(directory.Path());
  EXPECT_TRUE(Contains(InputErrorOf([&] {
                         WriteInto(directory.Path(), {{"calibration.yaml", "2"}});
                       }),
                       "report.html was changed since calibrate wrote it"));
  EXPECT_EQ(FilesIn(directory.Path()), before);
}

TEST(OutputDirectory, AFileInTheWayIsKeptUnderAnotherName) {
  TemporaryDirectory directory;
  WriteInto(directory.Path(), {{"calibration.yaml", "1"}});
  WriteFileAtomically(directory.Path() / "map.pcd", "mine");
  WriteFileAtomically(directory.Path() / "map.pcd.kept", "mine, older");
  OutputDirectory output(directory.Path(), "calibrate");
  const std::vector<std::string> kept = output.Replace(Writer({{"map.pcd", "2"}}));
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_TRUE(Contains(kept[0], "map.pcd.kept2"));
  EXPECT_EQ(ReadFile(directory.Path() / "map.pcd.kept2"), "mine");
  EXPECT_EQ(ReadFile(directory.Path() / "map.pcd.kept"), "mine, older");
  EXPECT_EQ(ReadFile(directory.Path() / "map.pcd"), "2");
}

TEST(OutputDirectory, ResultsOfAnotherProgramAreRefused) {
  TemporaryDirectory directory;
  WriteInto(directory.Path(), {{"calibration.yaml", "1"}});
  EXPECT_TRUE(Contains(InputErrorOf([&] { WriteInto(directory.Path(), {}, "evaluate"); }),
                       "holds results of calibrate; evaluate needs a folder of its own"));
  EXPECT_EQ(ResultsIn(directory.Path()), (Files{{"calibration.yaml", "1"}}));
}

// A manifest that somebody made up must not reach files elsewhere.
TEST(OutputDirectory, AManifestNamesNoFilesOutside) {
  TemporaryDirectory directory;
  const fs::path place = directory.Path() / "results";
  for (const std::string& outside : {std::string("../victim"), (directory.Path() / "victim").string()}) {
    WriteFileAtomically(directory.Path() / "victim", "mine");
    const std::string hash = ListFiles(directory.Path()).back().hash;
    WriteFileAtomically(place / kManifestName, "mlic_manifest/1 calibrate\n" + hash + " " + outside + "\n");
    EXPECT_TRUE(Contains(InputErrorOf([&] {
                           WriteInto(place, {{"calibration.yaml", "1"}});
                         }),
                         "that MLIC did not write"));
    EXPECT_EQ(ReadFile(directory.Path() / "victim"), "mine");
  }
}

TEST(OutputDirectory, AWriterThatThrowsLeavesTheResultsBefore) {
  TemporaryDirectory directory;
  WriteInto(directory.Path(), {{"calibration.yaml", "1"}});
  const Files before = FilesIn(directory.Path());
  OutputDirectory output(directory.Path(), "calibrate");
  const auto fail = [](const fs::path& partial) {
    WriteFileAtomically(partial / "calibration.yaml", "2");
    throw InputError("the disk is full");
  };
  EXPECT_TRUE(Contains(InputErrorOf([&] { output.Replace(fail); }), "the disk is full"));
  Files after = FilesIn(directory.Path());
  after.erase(kLockName);
  EXPECT_EQ(after, before);
}

// calibration.yaml is what others take for a result: it is there only with everything beside it.
TEST(OutputDirectory, WhereMovingFailsThereIsNoResultFile) {
  TemporaryDirectory directory;
  WriteInto(directory.Path(), {{"calibration.yaml", "1"}});
  WriteFileAtomically(directory.Path() / "images", "a file where a folder must be");
  OutputDirectory output(directory.Path(), "calibrate");
  const Files fresh{{"calibration.yaml", "2"}, {"images/a.png", "2"}};
  EXPECT_TRUE(Contains(InputErrorOf([&] { output.Replace(Writer(fresh)); }), directory.Path().string()));
  EXPECT_FALSE(fs::exists(directory.Path() / "calibration.yaml"));
  EXPECT_EQ(ReadFile(directory.Path() / "images"), "a file where a folder must be");
}

// A process that was killed in any step leaves files of its own results or of those before, all listed.
TEST(OutputDirectory, AKilledRunLeavesAFolderThatCanBeUsed) {
  TemporaryDirectory directory;
  WriteInto(directory.Path(), {{"calibration.yaml", "1"}, {"a", "1"}, {"b", "1"}});
  const pid_t child = fork();
  if (child == 0) {
    OutputDirectory output(directory.Path(), "calibrate");
    const auto die = [](const fs::path& partial) {
      WriteFileAtomically(partial / "a", "2");
      kill(getpid(), SIGKILL);
    };
    output.Replace(die);
  }
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(fs::exists(directory.Path() / kLockName)) << "the lock file of the dead process";
  WriteInto(directory.Path(), {{"calibration.yaml", "3"}});
  EXPECT_EQ(ResultsIn(directory.Path()), (Files{{"calibration.yaml", "3"}}));
}

TEST(OutputDirectory, ASecondProcessIsToldWhoWorksThere) {
  TemporaryDirectory directory;
  int ready[2], done[2];
  ASSERT_EQ(pipe(ready) + pipe(done), 0);
  const pid_t child = fork();
  if (child == 0) {
    char byte = 0;
    const OutputDirectory output(directory.Path(), "calibrate");
    const bool told = write(ready[1], &byte, 1) == 1 && read(done[0], &byte, 1) == 1;
    _exit(told ? 0 : 1);
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  EXPECT_TRUE(Contains(InputErrorOf([&] { OutputDirectory(directory.Path(), "calibrate"); }),
                       "in use by process " + std::to_string(child)));
  ASSERT_EQ(write(done[1], &byte, 1), 1);
  waitpid(child, nullptr, 0);
  EXPECT_EQ(InputErrorOf([&] { OutputDirectory(directory.Path(), "calibrate"); }), "no InputError");
}

TEST(OutputDirectory, UnusedFoldersGo) {
  TemporaryDirectory directory;
  { const OutputDirectory output(directory.Path() / "new", "calibrate"); }
  EXPECT_FALSE(fs::exists(directory.Path() / "new"));
  { const OutputDirectory output(directory.Path(), "calibrate"); }
  EXPECT_TRUE(fs::is_empty(directory.Path())) << "one that was there stays, as it was";
  WriteFileAtomically(directory.Path() / "file", "x");
  for (const fs::path& bad : {directory.Path() / "file", directory.Path() / "file" / "sub"}) {
    EXPECT_TRUE(Contains(InputErrorOf([&] { OutputDirectory(bad, "calibrate"); }), "file"));
  }
}

TEST(OutputDirectory, ResultsAreKnownAgainUntilOneIsMissing) {
  TemporaryDirectory directory;
  OutputDirectory output(directory.Path(), "calibrate");
  EXPECT_EQ(output.ResultsHash(), "");
  output.Replace(Writer({{"calibration.yaml", "1"}, {"a", "1"}}));
  const std::string hash = output.ResultsHash();
  EXPECT_NE(hash, "");
  fs::remove(directory.Path() / "a");
  EXPECT_EQ(output.ResultsHash(), "");
  output.Replace(Writer({{"calibration.yaml", "1"}, {"a", "2"}}));
  EXPECT_NE(output.ResultsHash(), hash);
}

}  // namespace
}  // namespace mlic::output_directory_test
