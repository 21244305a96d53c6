#include "common/util/secret.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "common/util/error.hpp"

namespace terravox::util {
namespace {

constexpr std::size_t kMaxFile_bytes = 4096;

std::string variable_of(const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr ? value : "";
}

// When both secrets had one name, each of them was sent to where the other one belongs.
void refuse_old_name() {
    if (variable_of("TERRAVOX_TOKEN").empty())
        return;
    throw UsageError(std::string("read the environment variable TERRAVOX_TOKEN: it was one name "
                                 "for two secrets; allowed: ") +
                     kFarmTokenVariable + " for a coordinator and its workers, " +
                     kServerTokenVariable + " for a voxel server and its clients");
}

// A file that systemd passes to a service (LoadCredential=): in a folder that only this service can
// enter. Newer versions let the group read the files, and name the service's user in an access
// control list.
bool is_credential_of_service(const std::filesystem::path& path) {
    const std::string folder = variable_of("CREDENTIALS_DIRECTORY");
    return !folder.empty() && path.lexically_normal().parent_path() ==
                                  std::filesystem::path(folder).lexically_normal();
}

std::string read_private_file(const std::filesystem::path& path, const std::string& attempt) {
    const auto failed = [&](const std::string& why) { return Error(attempt + ": " + why); };
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"),
                                                               &std::fclose);
    if (!file)
        throw failed(std::strerror(errno));
    struct stat facts{};
    if (::fstat(::fileno(file.get()), &facts) != 0)
        throw failed(std::strerror(errno));
    if (S_ISDIR(facts.st_mode))
        throw failed("it is a folder");
    const mode_t of_others = is_credential_of_service(path) ? 037 : 077;
    if (S_ISREG(facts.st_mode) && (facts.st_mode & of_others) != 0)
        throw failed("others may read or change it; allowed: only its owner (chmod 600)");
    std::string text(kMaxFile_bytes + 1, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), file.get()));
    if (std::ferror(file.get()) != 0)
        throw failed(std::strerror(errno));
    if (text.size() > kMaxFile_bytes)
        throw failed("it is longer than " + std::to_string(kMaxFile_bytes) + " bytes");
    return text;
}

}  // namespace

Secret find_secret(const std::filesystem::path& file, const char* variable) {
    refuse_old_name();
    Secret out;
    if (file.empty()) {
        out.attempt = std::string("read the environment variable ") + variable;
        out.text = variable_of(variable);
    } else {
        out.attempt = "read the token file " + file.string();
        out.text = read_private_file(file, out.attempt);
    }
    out.text.erase(out.text.find_last_not_of(" \t\r\n") + 1);
    return out;
}

std::string find_server_token(const std::filesystem::path& file) {
    const Secret found = find_secret(file, kServerTokenVariable);
    if (found.text.empty() && file.empty())
        return {};
    check_server_token(found);
    return found.text;
}

void check_server_token(const Secret& token) {
    // The token is sent in a header, and must not be able to end it.
    const bool fits = token.text.size() >= 8 && token.text.size() <= 512 &&
                      std::all_of(token.text.begin(), token.text.end(),
                                  [](char c) { return c > ' ' && c < 127; });
    if (!fits)
        throw UsageError(token.attempt +
                         ": the token does not fit a header; allowed: 8 to 512 visible ASCII "
                         "characters without a blank");
}

}  // namespace terravox::util
