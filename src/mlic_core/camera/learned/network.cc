#include "mlic_core/camera/learned/network.h"

namespace mlic {

std::string PortNames(const std::vector<NetworkPort>& ports) {
  std::string text;
  for (const NetworkPort& port : ports) text += (text.empty() ? "" : ", ") + port.names.front();
  return text;
}

std::string FirstLine(const std::string& message) { return message.substr(0, message.find('\n')); }

}  // namespace mlic
