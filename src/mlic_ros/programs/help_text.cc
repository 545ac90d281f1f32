#include "mlic_ros/programs/help_text.h"

#include <sstream>
#include <vector>

namespace mlic {
namespace {

constexpr std::size_t kWidth = 80;  // columns; from: standard, a terminal's

// The text in lines of at most kWidth columns, the first of which begins in first_column, the others
// indented.
std::string Wrapped(const std::string& text, std::size_t first_column, std::size_t indent) {
  std::istringstream words(text);
  std::string wrapped, word;
  std::size_t column = first_column;
  while (words >> word) {
    if (wrapped.empty()) {
      column += word.size();
    } else if (column + 1 + word.size() <= kWidth) {
      wrapped += " ";
      column += 1 + word.size();
    } else {
      wrapped += "\n" + std::string(indent, ' ');
      column = indent + word.size();
    }
    wrapped += word;
  }
  return wrapped;
}

bool TakesValue(const CLI::Option& option) { return option.get_items_expected_max() > 0; }
bool TakesSeveral(const CLI::Option& option) { return option.get_items_expected_max() > 1; }

// What stands for its value: the choices, where it has such, else a word.
std::string Value(const CLI::Option& option) {
  const std::string type = option.get_type_name();  // with what its checks say of themselves, after colons
  const std::size_t colon = type.find(':');
  if (colon == std::string::npos) return type;
  const std::string check = type.substr(colon + 1);
  if (!check.empty() && check.front() == '{') return check.substr(0, check.find('}') + 1);
  return type.substr(0, colon);
}

std::string Name(const CLI::Option& option) {
  std::string name;
  for (const std::string& one : option.get_snames()) name += (name.empty() ? "-" : ", -") + one;
  for (const std::string& one : option.get_lnames()) name += (name.empty() ? "--" : ", --") + one;
  if (name.empty()) return option.get_name(true);
  return TakesValue(option) ? name + " " + Value(option) : name;
}

// Option groups of the program: to CLI11 they are subcommands without a name.
std::vector<const CLI::App*> GroupsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* group) { return group->get_name().empty(); });
}

// A group has a --help of its own, which is the program's.
std::vector<const CLI::Option*> ArgumentsOfGroup(const CLI::App& group) {
  return group.get_options([](const CLI::Option* option) { return !option->check_lname("help"); });
}

std::string Usage(const CLI::App& app) {
  std::string usage;
  for (const CLI::App* group : GroupsOf(app)) {
    std::string choice;
    for (const CLI::Option* option : ArgumentsOfGroup(*group)) {
      choice += (choice.empty() ? "" : " | ") + Name(*option);
    }
    usage += " (" + choice + ")";
  }
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_required()) usage += " " + Name(*option) + (TakesSeveral(*option) ? " ..." : "");
  }
  const std::string start = "Usage: rosrun mlic " + app.get_name() + " ";
  return start + Wrapped(usage + " [OPTION ...]", start.size(), 4) + "\n";
}

std::string Described(const CLI::Option& option) {
  std::string text = option.get_description();
  if (!option.get_default_str().empty()) text += " (default: " + option.get_default_str() + ")";
  if (option.get_required()) text += " (required)";
  return "  " + Name(option) + (TakesSeveral(option) ? " ..." : "") + "\n      " + Wrapped(text, 6, 6) + "\n";
}

}  // namespace

std::string HelpText(const CLI::App& app) {
  std::string text = Usage(app) + "\n" + Wrapped(app.get_description(), 0, 0) + ".\n\nArguments:\n";
  for (const CLI::App* group : GroupsOf(app)) {
    for (const CLI::Option* option : ArgumentsOfGroup(*group)) text += Described(*option);
  }
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_group().empty())
      text += Described(*option);  // without one: for launch files, not for people
  }
  return text + app.get_footer();
}

}  // namespace mlic
