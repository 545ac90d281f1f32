#include "mlic_ros/programs/drive_list.h"

#include <gtest/gtest.h>

#include "mlic_core/io/text_file.h"
#include "support/files.h"

namespace mlic::drive_list_test {
namespace {

namespace fs = std::filesystem;

class DriveList : public ::testing::Test {
 protected:
  fs::path Write(const std::string& name, const std::string& text) const {
    WriteFileAtomically(folder_.Path() / name, text);
    return folder_.Path() / name;
  }

 private:
  TemporaryDirectory folder_;
};

TEST_F(DriveList, NamesDrivesAsTheirBags) {
  const fs::path monday = Write("monday.bag", ""), first = Write("long drive 0.bag", ""),
                 second = Write("long drive 1.bag", "");
  const std::vector<ListedDrive> drives = ReadDriveList(
      Write("list.txt", "# of one week\n\n  monday.bag  \r\nlong drive 0.bag " + second.string() + "\n"));
  ASSERT_EQ(drives.size(), 2u);
  EXPECT_EQ(drives[0].name, "monday");
  EXPECT_EQ(drives[0].bags, std::vector<fs::path>{monday});
  EXPECT_EQ(drives[1].name, "long drive 0");
  EXPECT_EQ(drives[1].bags, (std::vector<fs::path>{first, second}));
}

TEST_F(DriveList, TellsDrivesApartByTheirFolders) {
  Write("day_1/car/drive.bag", "");
  Write("day_2/car/drive.bag", "");
  const std::vector<ListedDrive> drives =
      ReadDriveList(Write("list.txt", "day_1/car/drive.bag\nday_2/car/drive.bag\n"));
  ASSERT_EQ(drives.size(), 2u);
  EXPECT_EQ(drives[0].name, "day_1_car_drive");
  EXPECT_EQ(drives[1].name, "day_2_car_drive");
}

TEST_F(DriveList, SaysWhatIsWrongAndInWhichLine) {
  const fs::path bag = Write("a.bag", ""), list = Write("list.txt", "a.bag\n./a.bag\n");
  EXPECT_TRUE(Contains(InputErrorOf([&] { ReadDriveList(list); }), "list.txt, line 2: "));
  EXPECT_TRUE(Contains(InputErrorOf([&] { ReadDriveList(list); }), "is in the list already"));
  Write("list.txt", "a.bag b.bag\n");
  EXPECT_TRUE(Contains(InputErrorOf([&] { ReadDriveList(list); }), "b.bag: no such file"));
  Write("list.txt", "# none\n");
  EXPECT_TRUE(Contains(InputErrorOf([&] { ReadDriveList(list); }), "names no drive"));
}

}  // namespace
}  // namespace mlic::drive_list_test
