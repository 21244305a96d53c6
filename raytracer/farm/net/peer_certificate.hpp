#pragma once

#include <grpcpp/security/auth_context.h>
#include <openssl/x509.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace terravox::net {

/// What a certificate lets its owner be. It stands in the certificate as a URI among its
/// alternative names: kRoleUri and the role.
inline constexpr std::string_view kWorkerRole = "worker";  ///< renders for coordinators
inline constexpr std::string_view kCoordinatorRole =
    "coordinator";  ///< has pictures rendered; asks for states, and pauses
inline constexpr std::string_view kRoleUri = "urn:terravox:farm:";

/// @return kWorkerRole, kCoordinatorRole, or empty: it names none
[[nodiscard]] std::string role_of(X509* certificate);

/// The list of revoked certificates of a CA (X.509 CRL, PEM), which lies beside it: ca.crl for
/// ca.pem. It is read for each connection, and again for those that are there once its file has
/// changed (RevocationWatch).
[[nodiscard]] std::filesystem::path revocation_list_of(const std::filesystem::path& ca);

/// What a certificate says of its owner.
struct Certified {
    std::string role;  ///< kWorkerRole or kCoordinatorRole
    std::string name;  ///< its common name
    std::string pem;   ///< all of it
};

/// What the certificate says that the other end of a TLS connection has shown, which gRPC has found
/// to be of this CA.
/// @param ca file of the CA's certificate
/// @throws RefusedError for a certificate without kFarmName or a role, or one that is revoked;
/// Error for a list of revoked ones that cannot be read, or that this CA has not signed: then
/// nobody is let in
[[nodiscard]] Certified certified_peer(const grpc::AuthContext& context,
                                       const std::filesystem::path& ca);

/// Looks whether a certificate that was let in is revoked meanwhile. Thread-safe.
///
/// A look costs a stat() while the list's file is as it was. A list that cannot be read, as one
/// that is being copied just now, is told in the log and read again with the next look; until then
/// it takes nobody's link, while new connections are refused.
class RevocationWatch {
public:
    /// @param certificate PEM @param ca file of the CA's certificate
    RevocationWatch(std::string certificate, std::filesystem::path ca);
    [[nodiscard]] bool is_revoked();

private:
    /// What tells a file from the same one before: device, inode, size, and times of content and
    /// inode in ns; nullopt: there is none.
    using Stamp = std::optional<std::array<std::int64_t, 5>>;
    [[nodiscard]] static Stamp stamp_of(const std::filesystem::path& file) noexcept;

    const std::string m_certificate;
    const std::filesystem::path m_ca, m_list;
    std::mutex m_mutex;
    Stamp m_read, m_told;  ///< of the list that was read last, and of the last that could not be
    bool m_revoked = false;
};

}  // namespace terravox::net
