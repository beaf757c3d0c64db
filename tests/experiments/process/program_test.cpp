// A program that is run gets its arguments as they are, and nothing else of ours.

#include "experiments/process/program.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/temporary_folder.h"

namespace romano::experiments::program_test {
namespace {

TEST(Programs, GetTheirArgumentsAsTheyAre) {
    const ProgramEnd end = run_program("printf", {"%s|%s", "it's $HOME", "a\nb; `exit 3`"});
    EXPECT_TRUE(end.ok());
    EXPECT_EQ(end.output, "it's $HOME|a\nb; `exit 3`");
}

TEST(Programs, TellTheirExitCode) {
    EXPECT_EQ(run_program("/bin/sh", {"-c", "echo no >&2; exit 3"}).exit_code, 3);
    EXPECT_EQ(run_program("no-such-program", {}).exit_code, 127);
    EXPECT_EQ(run_program("/nowhere/program", {}).exit_code, 127);
}

TEST(Programs, RunInTheFolderThatIsNamed) {
    const tests::TemporaryFolder folder;
    const auto here = std::filesystem::canonical(folder / ".");
    EXPECT_EQ(run_program("pwd", {}, here).output, here.string() + "\n");
}

TEST(Programs, InheritNothingButTheirStreams) {
    const int inheritable = ::dup(STDERR_FILENO);
    // The fourth is the folder's own, which `ls` reads.
    EXPECT_EQ(run_program("ls", {"/proc/self/fd"}).output, "0\n1\n2\n3\n");
    ::close(inheritable);
}

}  // namespace
}  // namespace romano::experiments::program_test
