#include "voxelserver/serve/http/bearer_token.hpp"

#include <string_view>

namespace terravox::http {
namespace {

// Takes the same time for every token, so that the time does not reveal how much of it was right.
bool same_secret(std::string_view given, std::string_view wanted) noexcept {
    unsigned difference = given.size() == wanted.size() ? 0 : 1;
    for (std::size_t i = 0; i < wanted.size(); ++i)
        difference |= static_cast<unsigned char>(wanted[i]) ^
                      static_cast<unsigned char>(given.empty() ? 0 : given[i % given.size()]);
    return difference == 0;
}

}  // namespace

bool BearerToken::is_in(const Request& request) const {
    const std::string given = request.header("Authorization");
    constexpr std::string_view kScheme = "Bearer ";
    return is_required() && given.size() > kScheme.size() &&
           same_word(std::string_view(given).substr(0, kScheme.size()), kScheme) &&
           same_secret(std::string_view(given).substr(kScheme.size()), m_secret);
}

}  // namespace terravox::http
