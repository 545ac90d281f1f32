#pragma once

#include <functional>
#include <string>

namespace mlic {

// Runs the work in a child process and waits for it, so that a node which dies (of a crash, or of memory that
// ran out) still has a last word. Signals to this process are handed on to the child, which dies with it. To
// be called before any thread is started. on_death(signal) is called, here, when a signal ended the child.
// Returns the child's exit status, or what on_death returned.
int Supervise(const std::function<int()>& work, const std::function<int(int)>& on_death);

// Ends the launch that started this process, roslaunch being its parent, as Ctrl-C would, unless it is ending
// already; waits until roslaunch asks this process to end too. roslaunch then says which processes it ends:
// last_words are written to stderr after that, so that they are the last ones on the terminal.
void EndLaunch(const std::string& last_words);

// For a program that ends its launch itself: writes the status and the last line into the file that
// MLIC_STATUS_FILE of the environment names, if any, and ends the launch with that line.
void EndLaunchWith(int status, const std::string& last_line);

}  // namespace mlic
