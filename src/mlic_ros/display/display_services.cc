#include "mlic_ros/display/display_services.h"

#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <utility>

#include "mlic/Choose.h"

namespace mlic {
namespace {

template <typename Response>
bool Give(const Answer& answer, Response* response) {
  response->success = answer.success;
  response->message = answer.message;
  return true;
}

}  // namespace

void DisplayServices::OfferWord(const std::string& name, std::function<Answer(const std::string&)> ask) {
  servers_.push_back(node_.advertiseService<Choose::Request, Choose::Response>(
      name, [ask = std::move(ask)](Choose::Request& request, Choose::Response& response) {
        return Give(ask(request.value), &response);
      }));
}

void DisplayServices::OfferSwitch(const std::string& name, std::function<Answer(bool)> ask) {
  using std_srvs::SetBool;
  servers_.push_back(node_.advertiseService<SetBool::Request, SetBool::Response>(
      name, [ask = std::move(ask)](SetBool::Request& request, SetBool::Response& response) {
        return Give(ask(request.data != 0), &response);
      }));
}

void DisplayServices::OfferTrigger(const std::string& name, std::function<Answer()> ask) {
  using std_srvs::Trigger;
  servers_.push_back(node_.advertiseService<Trigger::Request, Trigger::Response>(
      name, [ask = std::move(ask)](Trigger::Request&, Trigger::Response& response) {
        return Give(ask(), &response);
      }));
}

}  // namespace mlic
